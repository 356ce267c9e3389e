"""What the scripts in Python share. A script finds it next to itself, whatever folder it is called from."""
