"""What every floor shares: types of a response, errors, families of parts, fitted numbers."""
