// Compiled for the headers before it: see tests/CMakeLists.txt.
