"""What follows: certificates, internal model, exponents."""
