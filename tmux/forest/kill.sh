#!/usr/bin/env bash
# Ends the session.
tmux -L mrs kill-session -t simulation
