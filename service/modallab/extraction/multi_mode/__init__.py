"""All modes of all FRFs at once: poles by rising orders, their choice, one weighted fit."""
