# shellcheck shell=bash
# Makes hosts of network namespaces, joined by a bridge; sourced by what runs in them.
#
# Everything is in namespaces of the calling script's own (network, mounts, names, processes), which the kernel takes
# away with its last process, however that ends. So nothing is left behind and no name can be in use. A user who is not
# root may do this too, where the kernel allows user namespaces.

# in_own_namespaces SCRIPT ARGUMENT...: runs the script again inside; returns only where namespaces cannot be made.
in_own_namespaces() {
  local users=() all=(--net --mount --uts --pid --fork --mount-proc --kill-child)
  ((EUID == 0)) || users=(--user --map-root-user)
  command -v unshare ip >/dev/null || return 0
  unshare "${users[@]}" "${all[@]}" sh -c 'ip link add bridge0 type bridge && ip link add veth0 type veth peer name veth1' 2>/dev/null || return 0
  exec env RINGSPLAT_OWN_NAMESPACES=1 unshare "${users[@]}" "${all[@]}" bash "$@"
}

# make_hosts COUNT FOLDER: host1, host2, ... with addresses 10.77.0.1, ...; their names in FOLDER/hosts.
make_hosts() {
  local k
  mkdir -p /run && mount -t tmpfs none /run && mkdir /run/netns
  echo '127.0.0.1 localhost' >"$2/hosts"
  ip link set lo up
  ip link add bridge0 type bridge
  ip link set bridge0 up
  for ((k = 1; k <= $1; ++k)); do
    ip netns add "host$k"
    ip link add "to_host$k" type veth peer name eth0 netns "host$k"
    ip link set "to_host$k" master bridge0 up
    ip -n "host$k" addr add "10.77.0.$k/24" dev eth0
    ip -n "host$k" link set lo up
    ip -n "host$k" link set eth0 up
    echo "10.77.0.$k host$k" >>"$2/hosts"
  done
  mount --bind "$2/hosts" /etc/hosts
}

# bytes_through HOST: what it has sent to the others.
bytes_through() { awk -v name="to_$1:" '$1 == name { print $2 }' /proc/net/dev; }
