"""Lets h5py read the panoramas of compressed rooms.

    import h5py
    import raywalk.hdf5

    rays = h5py.File("room.lf/lines/x0.h5")["rays"]

The import tells the HDF5 library of h5py where Raywalk's filter is. Nothing else has to be done.
"""

import pathlib

import h5py

FILTER_ID = 456
"""The filter's number, from the range that HDF5 leaves for use outside its registry."""

h5py.h5pl.prepend(bytes(pathlib.Path(__file__).parent / "hdf5_filters"))
if not h5py.h5z.filter_avail(FILTER_ID):
    raise ImportError("HDF5 cannot load Raywalk's filter; is its library beside raywalk/hdf5.py?")
