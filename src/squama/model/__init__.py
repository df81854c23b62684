"""Pure algebra of the mechanics, generic over the number type."""
