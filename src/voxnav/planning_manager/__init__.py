# SPDX-License-Identifier: BSD-3-Clause
"""The planning manager turns a goal into verified trajectories, in plain Python without ROS, threads and clocks.

There are three states (states.py), each with its own data. Every transition is a function of the state, the time and
the event, and returns the next state and the actions to be done (actions.py). C++ does what must be fast or exact: the
search and the cut of its path (run_plan_job), corridors and stops (safe_part), trajectories.

=========  =======================================  ========================  ======================  ================
from       what happens                             to                        actions                 function
=========  =======================================  ========================  ======================  ================
any        a goal is set                            Planning                                          accept_goal
any        stop is commanded                        Idle, goal dropped        Hover                   stop
any        tick: somebody else hovers, lands, or    Idle, goal dropped                                drop_goal
           commands the vehicle
any        tick: a hover is not accepted yet        as it was                 Hover again each 1 s    repeat_hover
any        the hover is accepted or refused         as it was                                         hover_answered
any        tick: an input is missing                Idle, goal kept           Hover if in motion      lose
any        tick: the clock jumped back              Idle, goal kept           Hover if in motion      jump_clock
Idle       tick: nothing is missing, goal kept      Planning                  Plan                    resume
P, M       the odometry frame jumped, in motion     Planning                  Hover                   jump_frame
P, M       the odometry frame jumped, at rest       as it was, job dropped                            jump_frame
P, M       tick: at rest at the goal                Idle, goal reached                                arrival
P, M       tick: a job does not answer              M if flown, else P                                fail
P, M       tick: no progress for stuck_time_s       Idle, goal dropped        Hover                   stop
P, M       tick: a plan is due                      M if flown, else P        Plan                    start_plan
P, M       a search ends, worth flying              as it was                 Generate                plan_done
P, M       a search ends, not worth flying          as it was                                         plan_done
P, M       a search ends without a way              M if flown, else P                                fail
P, M       a search ends beside a blocked goal      Idle, goal dropped        Hover                   stop
P, M       a trajectory is generated and safe       as it was                 Publish                 generate_done
P, M       no trajectory, or an unsafe one          M if flown, else P                                fail
P, M       the tracker takes the trajectory         Moving                                            publish_done
P, M       the tracker refuses it                   M if flown, else P                                fail
Planning   the tracker takes a shortened one        Planning                                          publish_done
Planning   the tracker refuses a shortened one      Planning                  Hover                   brake
P, M       a trajectory is taken that nobody        Planning                  Hover                   brake
           waits for any more
P, M       check: the corridor is not known free    Planning                  Publish, shortened      check
P, M       check: and there is no room to stop,     Planning                  Hover                   brake
           or shortening has not come in time
=========  =======================================  ========================  ======================  ================

P is Planning, M is Moving. All other events, and answers to jobs that no longer matter, leave the state as it is.
"""

from voxnav.planning_manager.actions import Action, Generate, Hover, Plan, Publish
from voxnav.planning_manager.manager import PlanningManager
from voxnav.planning_manager.reasons import Because, Level, Reason
from voxnav.planning_manager.states import Idle, Moving, Planning

__all__ = ["Action", "Because", "Generate", "Hover", "Idle", "Level", "Moving", "Plan", "Planning", "PlanningManager",
           "Publish", "Reason"]
