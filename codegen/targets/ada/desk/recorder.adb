--  On a desk: the first events are kept in memory, and printed at the end.

with Ada.Text_IO; use Ada.Text_IO;
with Log;

package body Recorder is

   procedure Note (Event : Event_Index) is
   begin
      if Log.Length < Log.Most then
         Log.Length := Log.Length + 1;
         Log.Events (Log.Length) := Event;
      end if;
   end Note;

   procedure Failure (Index : Task_Index; What : String) is
   begin
      Put_Line (Standard_Error, "task" & Task_Index'Image (Index) & " has failed: " & What);
   end Failure;

end Recorder;
