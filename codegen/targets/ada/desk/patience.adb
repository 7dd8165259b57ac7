with Ada.Dispatching;
with Ada.Real_Time; use Ada.Real_Time;

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

end Patience;
