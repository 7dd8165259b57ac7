--  Processes that synchronise on events, under the Ravenscar profile: one task a process, nothing allocated.
--
--  Every task is a machine: a table of states, with the events that it offers in each. A task that waits has put its state
--  on the board, a protected object; in one protected action exactly one event that all tasks of one of its groups offer is
--  chosen for all of them at once, and the gate of each is opened. A gate has one entry and one caller. That is the commit
--  protocol of specs/channels/commit.csp, checked to be external choice.

with System;
with Tables; use Tables;

package CSP is

   subtype Task_Index is Natural range 0 .. Task_Count - 1;

   --  How the choices are made that the specification leaves open; call before the tasks run.
   procedure Seed (Value : Natural);

   --  One of Count possibilities, from 0 on
   procedure Decide (Count : Positive; Taken : out Natural);

   --  The body of every task
   task type Carrier (Index : Task_Index; Urgency : System.Priority) with Priority => Urgency;

   --  What happened, for a program that is watched: the first Most_Recorded events
   Most_Recorded : constant := 1_000_000;
   type Ending is (Goes_On, Enough, Deadlock, Ended, Broken);

   procedure Limit (Events : Natural);
   function Happened return Natural;
   function Recorded (Number : Positive) return Event_Index;
   function State return Ending;

   --  Time goes on by a tick, which is a millisecond
   procedure Tick;

end CSP;
