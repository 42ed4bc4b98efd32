"""Ready-to-run scenes, one TOML file each, and the characters that they share."""
