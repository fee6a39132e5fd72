"""The perceived-rule model (`field`): perception apart from an inferred rule."""
