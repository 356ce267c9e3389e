"""What the scripts in Python share. A script finds it beside itself, in whatever folder it is called."""
