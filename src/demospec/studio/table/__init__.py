"""The page Table: the picture, its scale, start and goal, the objects and their names."""
