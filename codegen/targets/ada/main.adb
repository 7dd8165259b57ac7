--  The program on its target: its time goes on by a tick each millisecond.

with Ada.Real_Time; use Ada.Real_Time;
with CSP;
with Processes;
pragma Unreferenced (Processes);

procedure Main is
   Next : Time := Clock;
begin
   CSP.Go;
   loop
      Next := Next + Milliseconds (1);
      delay until Next;
      CSP.Tick;
   end loop;
end Main;
