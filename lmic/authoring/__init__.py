"""Writing theorems of one's own: ``lmic new`` and ``lmic check``."""
