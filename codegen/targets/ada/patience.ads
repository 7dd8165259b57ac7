--  Whether a task looks if what it waits for has come, before it waits at its gate: never on a target.

with Tables; use Tables;

package Patience is

   pragma Warnings (Off, "formal parameter * is not referenced");

   function Looks (Index : Task_Index; Look : Positive) return Boolean is (False);

   procedure Yield (Index : Task_Index) is null;

end Patience;
