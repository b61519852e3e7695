"""What all commands share, and the commands that stand beside no other room."""
