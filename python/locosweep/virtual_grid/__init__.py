"""Virtual grids: sweeps of any size as xarray datasets that compute what is taken from them."""
