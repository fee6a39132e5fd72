"""Scene codes: a picture as table, light and objects; reading, drawing and sampling."""
