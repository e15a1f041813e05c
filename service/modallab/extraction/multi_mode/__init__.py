"""Multi-mode methods: poles of all FRFs at rising orders, selection of modes, one weighted fit."""
