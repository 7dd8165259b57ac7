--  The run, as far as it is kept.

with Tables; use Tables;

package Log is

   Most : constant := 1_000_000;

   Events : Event_Array (1 .. Most) := (others => 0);
   Length : Natural := 0;

end Log;
