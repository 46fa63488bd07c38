"""The recursive least squares of e-foc."""

NAME = "e-foc, recursive least squares"
LICENCE = "its own, for non-commercial use only"
NEEDS = []
NOT_RUN = "the licence forbids it to commercial users, so it is not fetched"
