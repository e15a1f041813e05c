"""What model, log book and effects predict for a measurement, or for several."""
