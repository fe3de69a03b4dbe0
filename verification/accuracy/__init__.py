"""How often the method names the right object, beside simpler methods on the same features and scenes."""
