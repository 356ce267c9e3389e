"""The mutation run of scripts/mutate: small faults in the model's sources, and whether a test notices them."""
