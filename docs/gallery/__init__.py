"""The gallery of effects: what each does to a measurement, as a picture and a page."""
