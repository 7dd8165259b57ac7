--  Processes that synchronise on events, under the Ravenscar profile: one task a process, nothing allocated.
--
--  Every task is a machine: a table of states, with the events that it offers in each. Events come about in two ways.
--
--  Where a sender offers nothing else and its receiver only receives, a channel is a protected object with a slot for
--  each sender (Links): the sender puts and stays at its gate; the receiver says what it wants, stays at its gate until
--  that has come, gets it and lets the sender proceed. That is the repaired channel of specs/channels/data_sync.csp
--  (SlotsSignalled).
--
--  Everything else is decided on the board: a task that waits has put its state there; in one protected action one
--  event that all tasks of one of its groups offer is chosen for all of them at once, and the gate of each is opened.
--  That is the commit protocol of specs/channels/commit.csp. A gate is a suspension object, at which only its task waits.

with System;
with Interfaces; use Interfaces;
with Tables;     use Tables;

package CSP is

   subtype Word is Unsigned_64;
   --  A set of tasks

   function Bit (Index : Task_Index) return Word is (Shift_Left (Word'(1), Index));

   --  How the choices are made that the specification leaves open; call before Go
   procedure Seed (Value : Natural);

   --  The tasks wait until then
   procedure Go;

   --  The body of every task
   task type Carrier (Index : Task_Index; Urgency : System.Priority) with Priority => Urgency;

   type Ending is (Goes_On, Enough, Deadlock, Ended, Broken);

   --  No more than so many events
   procedure Limit (Events : Natural);
   function Happened return Natural;
   function State return Ending;

   --  Time goes on by a tick, which is a millisecond
   procedure Tick;

   --  A channel (or several that one task chooses between) with a slot for each sender. Each is declared with numbers for
   --  its discriminants, so nothing is allocated.
   pragma Warnings (Off, "creation of protected object*");
   protected type Link (Senders : Positive; Receiver : Task_Index) with Priority => System.Priority'Last - 1 is
      procedure Put (Slot : Positive; Sender : Task_Index; Event : Event_Index);
      procedure Want (Place : State_Index; Found : out Boolean);
      procedure Get (Event : out Event_Index; Sender : out Task_Index; Open : out Boolean);
   private
      Events  : Event_Array (1 .. Senders) := (others => 0);
      Owners  : Task_Array (1 .. Senders) := (others => 0);
      Full    : Flag_Array (1 .. Senders) := (others => False);
      Last    : Positive := 1;
      Chosen  : Positive := 1;
      Wanting : Boolean := False;
      Wanted  : State_Index := 0;
      Ready   : Boolean := False;
   end Link;
   pragma Warnings (On, "creation of protected object*");

end CSP;
