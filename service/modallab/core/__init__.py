"""Types common to all layers: DoFs, FRFs, modal models, errors, families of parts, parameters."""
