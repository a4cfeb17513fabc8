// Compiled for the headers before it: see rooms.cmake.
