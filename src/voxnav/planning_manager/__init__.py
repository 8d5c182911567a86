# SPDX-License-Identifier: BSD-3-Clause
"""The planning manager turns a goal into verified trajectories, in plain Python without ROS, threads and clocks.

There are three states (states.py), each with its own data. Every transition is a function of the state, the time and
the event, and returns the next state and the actions to be done (actions.py). C++ does what must be fast or exact: the
search and the cut of its path (run_plan_job), corridors (check_corridor, safe_part), trajectories.

=========  =======================================  ========================  ======================  ================
from       what happens                             to                        actions                 function
=========  =======================================  ========================  ======================  ================
any        a goal is set                            Planning                                          accept_goal
any        stop is commanded                        Idle, goal dropped        Hover                   stop
any        tick: a pilot, another node, or the      Idle, goal dropped                                drop_goal
           control manager itself has the vehicle
any        tick: a hover is not accepted yet        as it was                 Hover again each 1 s    repeat_hover
any        a hover is refused in motion             as it was                 Hover, stronger means   hover_answered
any        a hover is accepted, or refused at rest  as it was                                         hover_answered
any        a trajectory is taken after a hover      as it was                 Hover again             hover_again
any        tick: an input is missing or absurd      Idle, goal kept           Hover if in motion      lose
any        tick: somebody else flies the vehicle,   Idle, goal kept                                   lose
           and did so before the goal was set
any        tick: the clock jumped back              Idle, goal kept           Hover if in motion      jump_clock
Idle       tick: nothing is missing, goal kept      Planning                  Plan                    resume
Idle       tick: a trajectory is flown that the     Idle                      Hover                   stop_late
           tracker took after the goal was dropped
Idle       check: somebody else flies where it is   Idle, with a warning                              check_others
           not known free
any        the map of the goal was closed           Idle, goal dropped        Hover if in motion      close_map
any        the control manager refuses the goal     Idle, goal dropped        Hover if in motion      drop
P, M       the odometry frame jumped, in motion     Planning                  Hover                   jump_frame
P, M       the odometry frame jumped, at rest       as it was, job dropped                            jump_frame
P, M       tick: at rest at the goal                Idle, goal reached                                arrival
P, M       tick: a job does not answer              M if flown, else P                                fail
P, M       tick: no shorter way to the goal for     Idle, goal dropped        Hover                   give_up
           stuck_time_s, or max_dead_ends
P, M       tick: a plan is due                      M if flown, else P        Plan                    start_plan
P, M       a search cannot be made                  M if flown, else P                                plan_failed
P, M       a search ends, worth flying              as it was                 Generate                plan_done
P, M       a search ends, no better than what is    as it was                                         plan_done
           flown
P, M       a search ends, nothing is worth flying   M if flown, else P                                no_way
P, M       a search ends, and it is decided that    Idle, goal dropped        Hover                   no_way
           the goal cannot be reached
P, M       a trajectory is generated and safe       as it was                 Publish                 generate_done
P, M       no trajectory, a late or another one     M if flown, else P                                fail
           than was asked for, or an unsafe one
P, M       the tracker takes the trajectory         Moving                                            publish_done
P, M       the tracker refuses it                   M if flown, else P                                fail
P, M       the control manager cuts it at its       Idle, goal dropped        Hover                   publish_done
           safety area
Planning   the tracker takes a shortened one        Planning                                          publish_done
Planning   the tracker refuses a shortened one      Planning                  Hover                   brake
P, M       a trajectory is taken that nobody        Planning                  Hover                   brake
           waits for any more
P, M       check: the corridor is not known free    Planning                  Publish, shortened      check_flight
P, M       check: and there is no room to stop,     Planning                  Hover                   brake
           or shortening has not come in time
P, M       check: far from the trajectory, or the   as it was, a plan is due                          plan_anew
           tracker leads away from it, or to what
           is not known free, with time for a plan
P, M       check: farther from the trajectory, or   Planning                  Hover                   brake
           the tracker leads there near by
P, M       check: the tracker leads off the         as it was, for 0.25 s                             check_flight
           trajectory, and diagnostics do not tell
           yet whether another node commands it
P, M       check: without a trajectory, in motion   Planning                  Hover                   check_rest
           towards what is not known free
any        check: the way of an accepted hover is   as it was                 Hover, other means      check_stop
           not free, and another one is better
=========  =======================================  ========================  ======================  ================

What a search tells about the goal stands in verdicts.py, and the rule of progress in progress.py.
Hover stands for the least dangerous of the ways to rest (stops.py): straight ahead, along the trajectory, or climbing.

P is Planning, M is Moving. All other events, and answers to jobs that no longer matter, leave the state as it is.
"""

from voxnav.planning_manager.actions import Action, Generate, Hover, Means, Plan, Publish
from voxnav.planning_manager.generated import Generated
from voxnav.planning_manager.inputs import Control
from voxnav.planning_manager.manager import PlanningManager
from voxnav.planning_manager.reasons import Because, Level, Reason
from voxnav.planning_manager.states import Idle, Moving, Planning

__all__ = ["Action", "Because", "Control", "Generate", "Generated", "Hover", "Idle", "Level", "Means", "Moving", "Plan",
           "Planning", "PlanningManager", "Publish", "Reason"]
