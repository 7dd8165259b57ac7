--  The program on a desk: it runs so many events (with a seed, if there is one) and prints them.

with Ada.Command_Line; use Ada.Command_Line;
with Ada.Real_Time;    use Ada.Real_Time;
with Ada.Text_IO;      use Ada.Text_IO;
with CSP;              use CSP;
with GNAT.OS_Lib;
with Log;
with Names;
with Processes;
pragma Unreferenced (Processes);

procedure Host is
   Most : Natural := 1_000;
begin
   if Argument_Count >= 1 then
      Most := Natural'Value (Argument (1));
   end if;
   if Argument_Count >= 2 then
      CSP.Seed (Natural'Value (Argument (2)));
   end if;
   CSP.Limit (Most);
   CSP.Go;
   while CSP.State = Goes_On loop
      delay until Clock + Microseconds (100);
      CSP.Tick;
   end loop;
   for Number in 1 .. Log.Length loop
      Put_Line (Names.Line (Log.Events (Number)));
   end loop;
   if CSP.State = Ended then
      Put_Line ("{""event"": ""tick"", ""terminated"": true}");
   end if;
   Put_Line
     (Standard_Error,
      Natural'Image (CSP.Happened) (2 .. Natural'Image (CSP.Happened)'Last)
      & (case CSP.State is
            when Goes_On | Enough => " events; stopped",
            when Deadlock         => " events; deadlock: every task waits for ever",
            when Ended            => " events; all tasks have ended",
            when Broken           => " events; a task has failed"));
   GNAT.OS_Lib.OS_Exit (if CSP.State in Deadlock | Broken then 1 else 0);
end Host;
