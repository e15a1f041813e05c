"""Tables, plots and arrays that generated result types have beside their fields."""
