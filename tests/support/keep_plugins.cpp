// Preloaded under the leak checker: a plugin that Open MPI or PMIx has unloaded could no longer be named in
// lsan.supp.
extern "C" int dlclose(void* /*library*/) { return 0; }
