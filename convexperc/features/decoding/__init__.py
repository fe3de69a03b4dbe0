"""Picture files: decoded exactly, or refused with the reason."""
