--  What becomes of the events. The body is called in a protected action: it must be short, and wait for nothing.

with Tables; use Tables;

package Recorder is

   --  An event has happened: events are numbered as in names.ads
   procedure Note (Event : Event_Index);

   --  A task has ended by an exception
   procedure Failure (Index : Task_Index; What : String);

end Recorder;
