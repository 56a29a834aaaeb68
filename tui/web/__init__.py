"""The console in a browser: who serves it, the process behind a tab, and how that process draws."""
