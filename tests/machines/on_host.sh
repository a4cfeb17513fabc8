#!/usr/bin/env bash
# The launcher's agent, called as ssh would be:  on_host.sh HOST COMMAND...
# A host has a name, a network and shared memory of its own.
host=$1
shift
exec ip netns exec "$host" unshare --uts --mount sh -c \
  'hostname "$0" && mount -t tmpfs none /dev/shm && exec sh -c "$1"' "$host" "$*"
