"""Plain commands, understood without a language model."""
