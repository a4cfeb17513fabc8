// What the sanitizers do here unless the environment says otherwise: one allocation is limited, a report ends
// the process with a code of its own, and children that share everything with this process search no leaks.
extern "C" const char* __asan_default_options() {
  return "exitcode=99:max_allocation_size_mb=512:allocator_may_return_null=0:quarantine_size_mb=16:"
         "hard_rss_limit_mb=4096:handle_abort=0:detect_leaks=0:intercept_tls_get_addr=0";
}
extern "C" const char* __ubsan_default_options() { return "exitcode=99:print_stacktrace=1"; }
