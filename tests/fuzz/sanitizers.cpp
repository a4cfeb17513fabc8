// Sanitizer defaults, which the environment can override: single allocations are limited, a report ends the
// process with an exit code of its own, and leaks are not searched, since children share everything with this
// process.
extern "C" const char* __asan_default_options() {
  return "exitcode=99:max_allocation_size_mb=512:allocator_may_return_null=0:quarantine_size_mb=16:"
         "hard_rss_limit_mb=4096:handle_abort=0:detect_leaks=0:intercept_tls_get_addr=0";
}
extern "C" const char* __ubsan_default_options() { return "exitcode=99:print_stacktrace=1"; }
