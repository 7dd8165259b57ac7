with Ada.Dispatching;
with Ada.Real_Time; use Ada.Real_Time;
with Interfaces.C;  use Interfaces.C;

package body Patience is

   Most     : constant := 20;
   Too_Long : constant Time_Span := Microseconds (700);
   Penalty  : constant := 200;

   type Count_Array is array (Task_Index) of Natural;
   At_Once : Count_Array := (others => 0);
   --  How many times more a task waits without a look; each changes its own.

   function Looks (Index : Task_Index; Look : Positive) return Boolean is
   begin
      if At_Once (Index) > 0 then
         if Look = 1 then
            At_Once (Index) := At_Once (Index) - 1;
         end if;
         return False;
      end if;
      return Look <= Most;
   end Looks;

   procedure Yield (Index : Task_Index) is
      Before : constant Time := Clock;
   begin
      Ada.Dispatching.Yield;
      if Clock - Before > Too_Long then
         At_Once (Index) := Penalty;
      end if;
   end Yield;

   --  A target has one processor, and so have the tasks here: the one that the program begins on. All tasks are made
   --  after this and inherit it. To wake one on another processor takes several times as long as the rest of an event.
   type Mask is array (0 .. 1023) of Boolean with Pack;
   Set : Mask := (others => False);

   function Sched_Get_CPU return int with Import, Convention => C, External_Name => "sched_getcpu";
   function Sched_Set_Affinity (Process : int; Size : size_t; Processors : in out Mask) return int
     with Import, Convention => C, External_Name => "sched_setaffinity";

   Processor : constant int := Sched_Get_CPU;
   Unused    : int;
begin
   if Processor in 0 .. int (Set'Last) then
      Set (Integer (Processor)) := True;
      Unused := Sched_Set_Affinity (0, Set'Size / 8, Set);
   end if;
end Patience;
