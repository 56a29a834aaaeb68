"""What the console shows, told from events alone: values that know no Textual."""
