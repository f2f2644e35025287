#!/usr/bin/env bash
# What a study costs as it grows, and that a cluster comes to the same table.
#   benches/studies/scale.sh cost FOLDER TRIALS…            processor time a trial and memory of so many trials, and of 1 to 8 shards of the first
#   benches/studies/scale.sh cluster FOLDER TRIALS LOOPBACK the same table from one run and from a Slurm of two nodes of which one is killed
# FOLDER: new, for results. LOOPBACK: a script that starts such a Slurm (start, kill-node, start-node, stop, each with a folder).
# Needs GNU time, and `cargo build --release --workspace --bin gravcal`.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
gravcal=$root/target/release/gravcal
action=${1:?cost or cluster}
mkdir -p "${2:?folder}" && folder=$(cd "$2" && pwd)

study() { # trials: the study with so many
    local file=$folder/study-$1.toml
    sed "s|\.\./\.\./experiments|$root/experiments|; s|^trials = .*|trials = $1|" "$root/benches/studies/million.toml" > "$file"
    echo "$file"
}
timed() { # file, command: appends processor seconds, seconds by the clock, largest memory in MB
    local times=$1; shift
    command time --append --output="$times" --format="%U %S %e %M" "$@" > "$folder/printed"
}
told() { # times, trials, what
    awk -v trials="$2" -v what="$3" '{ processor += $1 + $2; clock += $3; if ($4 > memory) memory = $4 }
        END { printf "%-22s %9d trials %9.1f processor s %9.1f s %8.3f ms/trial %6.0f MB\n", what, trials, processor, clock, 1e3 * processor / trials, memory / 1024 }' "$1"
}

on_node() { # node: processes of its tasks, and what watches these first, which would say that they failed
    local process variables
    for process in /proc/[0-9]*; do
        variables=$(tr '\0' '\n' 2> /dev/null < "$process/environ" || true)
        if grep -qx "SLURM_CONF=$SLURM_CONF" <<< "$variables" && grep -qx "SLURMD_NODENAME=$1" <<< "$variables"; then
            awk '/^PPid:/ && $2 > 1 { print $2 }' "$process/status"
            echo "${process#/proc/}"
        fi
    done | sort -nu
}

case $action in
cost)
    shift 2
    for trials in "$@"; do
        timed "$folder/run-$trials" "$gravcal" study run "$(study "$trials")" --output "$folder/run-of-$trials" --quiet
        told "$folder/run-$trials" "$trials" "one run"
    done
    for shards in 1 2 4 8; do
        parts=()
        for shard in $(seq "$shards"); do
            part=$folder/$shard-of-$shards
            timed "$folder/shards-$shards" "$gravcal" study run "$(study "$1")" --shard "$shard/$shards" --output "$part" --threads 1 --quiet
            parts+=("$part")
        done
        told "$folder/shards-$shards" "$1" "$shards shards"
        timed "$folder/merge-$shards" "$gravcal" study merge "${parts[@]}"
        told "$folder/merge-$shards" "$1" "their merging"
        cmp "${parts[0]}/trials.parquet" "$folder/run-of-$1/trials.parquet"
    done
    ;;
cluster)
    trials=${3:?trials} loopback=${4:?script that starts a Slurm}
    timed "$folder/run" "$gravcal" study run "$(study "$trials")" --output "$folder/alone" --quiet
    told "$folder/run" "$trials" "one run"
    slurm=$(mktemp -d /var/lib/gravcal-slurm.XXXXXX)
    trap '"$loopback" stop "$slurm"; sleep 2; rm -rf "$slurm"' EXIT
    "$loopback" start "$slurm" > "$folder/printed"
    export SLURM_CONF=$slurm/slurm.conf
    began=$SECONDS killed=
    "$gravcal" study submit "$(study "$trials")" --tasks 8 --output "$folder/cluster"
    while status=$("$gravcal" study status "$folder/cluster"); [[ $status != done:* ]]; do
        read -r parts _ all _ <<< "$status"
        if [ -z "$killed" ] && [ -n "$parts" ] && [ $((4 * parts)) -ge "$all" ] && tasks=$(on_node n1) && [ -n "$tasks" ]; then
            echo "after $((SECONDS - began)) s node n1 is killed with its task: $parts of $all parts are done"
            "$loopback" kill-node "$slurm" n1
            xargs kill -KILL <<< "$tasks"
            sleep 20
            "$loopback" start-node "$slurm" n1
            killed=yes
        fi
        sleep 1
    done
    echo "after $((SECONDS - began)) s $status"
    cmp "$folder/alone/trials.parquet" "$folder/cluster/trials.parquet"
    echo "the same table to the byte"
    ;;
*)
    echo "cost or cluster" >&2
    exit 2
    ;;
esac
