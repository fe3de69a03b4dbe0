"""Records, proof files, tables and the figure of what was found."""
