--  Whether a task looks if what it waits for has come, before it waits at its gate. On a desk a gate that is closed
--  puts its task to sleep in the kernel, which takes longer than most partners do; between looks the processor is the
--  partner's, if it wants it.

with Tables; use Tables;

package Patience is

   pragma Elaborate_Body;

   --  Whether it looks for the first, the second .. time
   function Looks (Index : Task_Index; Look : Positive) return Boolean;

   --  If another program has had the processor meanwhile, the task waits at its gate at once for some time.
   procedure Yield (Index : Task_Index);

end Patience;
