"""The command line of the verifier, one file a group of commands."""
