# Sourced by tests whose jobs are ended by MPI_Abort or by a signal.

# await_launcher PID LOG SECONDS: waits for mpiexec, whose stderr is LOG, and leaves its exit code in `code`. False
# if the job goes on after so many seconds.
# When Open MPI's launcher has ended a job it may crash, or hang for ever (in PMIx_server_finalize). Mostly it has
# said before with what code; `code` is -1 where it has not.
await_launcher() {
  local launcher=$1 log=$2 left=$((10 * $3)) alone=0
  while kill -0 "$launcher" 2>/dev/null && ((left-- > 0 && alone < 100)); do
    sleep 0.1
    if [[ $(ps -o state= --ppid "$launcher" | tr -d '\n') =~ ^Z+$ ]]; then alone=$((alone + 1)); else alone=0; fi
  done
  if kill -0 "$launcher" 2>/dev/null; then
    ((alone >= 100)) || return 1
    kill -KILL "$launcher"
  fi
  wait "$launcher"
  code=$?
  if ((alone >= 100)) || { ((code == 139)) && grep -q PMIx_server_finalize "$log"; }; then
    code=$(sed -n 's/^with errorcode \([0-9]*\)\.$/\1/p' "$log" | tail -n 1)
    code=${code:--1}
  fi
}
