"""Printed figures of the beam in chapter 5 of the 1992 thesis, modes 1 to 8; frequencies in Hz."""

Row = tuple[float, ...]

MEASURED: Row = (23.0, 62.5, 126.8, 209.7, 309.2, 440.2, 569.3, 751.7)

SCATTER: dict[str, Row] = {  # table 5.4, over the 11 FRFs; loss factors in %
    "frequency min": (22.9, 62.2, 126.3, 208.6, 308.2, 438.1, 567.2, 749.0),
    "frequency max": (23.0, 62.8, 127.1, 210.2, 309.8, 441.2, 570.6, 753.4),
    "frequency mean": (23.0, 62.6, 126.8, 209.7, 309.2, 440.2, 569.3, 751.7),
    "frequency sd": (0.05, 0.17, 0.24, 0.46, 0.58, 0.87, 0.98, 1.24),
    "loss_factor min": (0.98, 0.54, 0.51, 0.50, 0.50, 0.50, 0.51, 0.50),
    "loss_factor max": (1.09, 0.60, 0.54, 0.53, 0.53, 0.52, 0.51, 0.52),
    "loss_factor mean": (1.02, 0.57, 0.53, 0.52, 0.52, 0.51, 0.51, 0.51),
    "loss_factor sd": (0.04, 0.02, 0.01, 0.01, 0.01, 0.01, 0.00, 0.01),
}
MODEL: Row = (23.6, 65.2, 127.8, 211.3, 315.7, 441.1, 587.5, 755.2)  # table 5.5
MODEL_MAC: Row = (0.959, 0.952, 0.962, 0.956, 0.962, 0.928, 0.931, 0.904)
LOCATED: Row = (23.1, 61.7, 126.7, 205.8, 313.9, 440.0, 578.1, 748.6)  # table 5.6
LOCATED_MAC: Row = (1.000, 0.995, 0.987, 0.988, 0.980, 0.993, 0.994, 0.988)
UPDATED: Row = (22.8, 62.3, 126.5, 209.7, 309.1, 441.0, 570.2, 753.7)  # table 5.7
UPDATED_MAC: Row = (0.999, 1.000, 1.000, 0.999, 1.000, 0.999, 0.999, 0.999)

SUSPECTED = {"mass": 4, "stiffness": 12}  # elements that location leaves for updating
ITERATIONS = {"location": 4, "updating": 5}
