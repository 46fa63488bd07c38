"""The recursive least squares of PX4's autotuner."""

NAME = "PX4, ARX by recursive least squares"
LICENCE = "BSD-3, which allows to fetch it"
NEEDS = []
NOT_RUN = "part of a flight controller in C++: it needs its tree, its matrix library and a compiler at run time"
