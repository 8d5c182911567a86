#!/usr/bin/env bash
# Starts the session and attaches to it.
set -euo pipefail
cd "$(dirname "$0")"
export TMUX_SESSION_NAME=simulation TMUX_SOCKET_NAME=mrs
tmuxinator start -p session.yml
tmux -L "${TMUX_SOCKET_NAME}" attach -t "${TMUX_SESSION_NAME}"
