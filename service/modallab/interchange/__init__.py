"""Exchange files: universal files, HDF5, text FRFs, meshes and Nastran models."""
