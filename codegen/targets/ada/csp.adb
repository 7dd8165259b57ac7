with Ada.Exceptions;
with Ada.Synchronous_Task_Control; use Ada.Synchronous_Task_Control;
with Links;
with Methods_Table;
with Patience;
with Program_Data;
with Recorder;

package body CSP is

   --  Small tables leave nothing open of some conditions.
   pragma Warnings (Off, "condition can only be *");
   pragma Warnings (Off, "condition is always *");

   All_Tasks : constant Word :=
     (if Task_Count = 64 then Word'Last else Shift_Left (Word'(1), Task_Count) - 1);

   --  What a waiting task offers, and what was chosen for it
   type Party is record
      State    : State_Index := 0;
      Taken    : Event_Index := 0;
      Next     : State_Index := 0;
      Tocks    : Natural := 0;
      Releases : Natural := 0;
   end record;
   type Party_Array is array (Task_Index) of Party;

   --  Where a task waits until another lets it go on
   Gates : array (Task_Index) of Suspension_Object;

   procedure Stay (Index : Task_Index) is
      Look : Positive := 1;
   begin
      while Patience.Looks (Index, Look) and then not Current_State (Gates (Index)) loop
         Patience.Yield (Index);
         Look := Look + 1;
      end loop;
      Suspend_Until_True (Gates (Index));
   end Stay;

   --  Numbers the events, and knows which tasks wait: when all of them do, and none for a time, nothing happens any more
   protected Watch with Priority => System.Priority'Last is
      procedure Note (Event : Event_Index; Open : out Boolean);
      procedure Transfer (Event : Event_Index; Sender : Task_Index; Open : out Boolean);
      procedure Wait (Index : Task_Index; For_Time : Boolean);
      procedure Run (Index : Task_Index);
      procedure Leave (Index : Task_Index);
      procedure Fail;
      procedure Stop_After (Events : Natural);
      function Count return Natural;
      function How return Ending;
   private
      Idle     : Word := 0;
      Sleeping : Word := 0;
      Alive    : Word := All_Tasks;
      Number   : Natural := 0;
      Most     : Natural := 0;
      Closed   : Ending := Goes_On;
   end Watch;

   protected body Watch is

      procedure Look_For_The_End is
      begin
         if Closed = Goes_On and then Idle = Alive then
            if Alive = 0 then
               Closed := Ended;
            elsif Sleeping = 0 then
               Closed := Deadlock;
            end if;
         end if;
      end Look_For_The_End;

      procedure Note (Event : Event_Index; Open : out Boolean) is
      begin
         Open := Closed = Goes_On;
         if Open then
            Recorder.Note (Event);
            Number := (if Number = Natural'Last then 0 else Number + 1);
            if Number = Most then
               Closed := Enough;
            end if;
         end if;
      end Note;

      procedure Transfer (Event : Event_Index; Sender : Task_Index; Open : out Boolean) is
      begin
         Note (Event, Open);
         Idle := Idle and not Bit (Sender);
      end Transfer;

      procedure Wait (Index : Task_Index; For_Time : Boolean) is
      begin
         Idle := Idle or Bit (Index);
         Sleeping := (if For_Time then Sleeping or Bit (Index) else Sleeping and not Bit (Index));
         Look_For_The_End;
      end Wait;

      procedure Run (Index : Task_Index) is
      begin
         Idle := Idle and not Bit (Index);
         Sleeping := Sleeping and not Bit (Index);
      end Run;

      procedure Leave (Index : Task_Index) is
      begin
         Alive := Alive and not Bit (Index);
         Look_For_The_End;
      end Leave;

      procedure Fail is
      begin
         Closed := Broken;
      end Fail;

      procedure Stop_After (Events : Natural) is
      begin
         Most := Events;
      end Stop_After;

      function Count return Natural is (Number);
      function How return Ending is (Closed);

   end Watch;

   --  The first move of a task in a state with an event; 0 if there is none
   function Find (Index : Task_Index; State : State_Index; Event : Event_Index) return Natural is
      Row  : State_Record renames States (Tasks (Index).First_State + State);
      Low  : Natural := Row.First_Move;
      High : Natural := Row.First_Move + Row.Moves;
   begin
      while Low < High loop
         declare
            Middle : constant Natural := Low + (High - Low) / 2;
         begin
            if Moves (Middle).Event < Event then
               Low := Middle + 1;
            else
               High := Middle;
            end if;
         end;
      end loop;
      return (if Low < Row.First_Move + Row.Moves and then Moves (Low).Event = Event then Low else 0);
   end Find;

   --  How many moves of a state have the event of a first one
   function Alike (Index : Task_Index; State : State_Index; First : Natural) return Positive is
      Row   : State_Record renames States (Tasks (Index).First_State + State);
      Count : Positive := 1;
   begin
      while First + Count < Row.First_Move + Row.Moves and then Moves (First + Count).Event = Moves (First).Event loop
         Count := Count + 1;
      end loop;
      return Count;
   end Alike;

   --  The procedures of it are the only ones that change what it knows
   protected Board with Priority => System.Priority'Last - 1 is
      procedure Submit (Index : Task_Index; State : State_Index);
      procedure Outcome (Index : Task_Index; Event : out Event_Index; Next : out State_Index);
      procedure Choose (Count : Positive; Taken : out Natural);
      procedure Pass_Time;
      procedure Start (Value : Unsigned_32);
   private
      Parties  : Party_Array;
      Waiting  : Word := 0;
      Now      : Natural := 0;
      Random   : Unsigned_32 := 2463534242;
   end Board;

   protected body Board is

      procedure Choose (Count : Positive; Taken : out Natural) is
      begin
         Random := Random xor Shift_Left (Random, 13);
         Random := Random xor Shift_Right (Random, 17);
         Random := Random xor Shift_Left (Random, 5);
         Taken := Natural (Random mod Unsigned_32 (Count));
      end Choose;

      function Due (Index : Task_Index; Channel : Channel_Index) return Natural is
        (if Channels (Channel).Clocked then (Parties (Index).Tocks + 1) * Tock_Ms
         elsif Tasks (Index).Timed = Channel
         then Tasks (Index).Offset_Ms + Parties (Index).Releases * Tasks (Index).Period_Ms
         else 0);

      function All_Offer (Group : Word; But : Task_Index; Event : Event_Index) return Boolean is
        (for all Index in Task_Index =>
           (Group and Bit (Index)) = 0 or else Index = But
           or else (Due (Index, Channel_Of (Event)) <= Now
                    and then Find (Index, Parties (Index).State, Event) /= 0));

      procedure Take (Index : Task_Index; Event : Event_Index) is
         First : constant Natural := Find (Index, Parties (Index).State, Event);
         Count : constant Positive := Alike (Index, Parties (Index).State, First);
         Which : Natural := 0;
      begin
         if Count > 1 then
            Choose (Count, Which);
         end if;
         Parties (Index).Next := Moves (First + Which).Next;
         Parties (Index).Taken := Event;
         Waiting := Waiting and not Bit (Index);
         if Channels (Channel_Of (Event)).Clocked then
            Parties (Index).Tocks := Parties (Index).Tocks + 1;
         end if;
         if Tasks (Index).Timed = Channel_Of (Event) then
            Parties (Index).Releases := Parties (Index).Releases + 1;
         end if;
      end Take;

      procedure Commit (Index : Task_Index; Done : out Boolean) is
         State : State_Record renames States (Tasks (Index).First_State + Parties (Index).State);
         Start : Natural := 0;
         Best  : Event_Index := 0;
         Group : Word := 0;
         Rank  : Natural := Natural'Last;
         Open  : Boolean := True;
      begin
         Done := False;
         if State.Moves = 0 then
            return;
         end if;
         if State.Moves > 1 then
            Choose (State.Moves, Start);
         end if;
         for Step in 0 .. State.Moves - 1 loop
            declare
               Event   : constant Event_Index := Moves (State.First_Move + (Start + Step) mod State.Moves).Event;
               Channel : constant Channel_Index := Channel_Of (Event);
            begin
               if Channels (Channel).Rank < Rank and then Due (Index, Channel) <= Now then
                  for G in Groups (Event).First .. Groups (Event).First + Groups (Event).Count - 1 loop
                     if (Members (G) and Bit (Index)) /= 0 and then (Members (G) and Waiting) = Members (G)
                       and then All_Offer (Members (G), Index, Event)
                     then
                        Best := Event;
                        Group := Members (G);
                        Rank := Channels (Channel).Rank;
                        exit;
                     end if;
                  end loop;
               end if;
            end;
            exit when Rank = 0;
         end loop;
         if Group = 0 then
            return;
         end if;
         if Group /= Bit (Index) or else not Methods_Table.Has (Index, Channel_Of (Best)) then
            Watch.Note (Best, Open);
         end if;
         if not Open then
            return;
         end if;
         for Other in Task_Index loop
            if (Group and Bit (Other)) /= 0 then
               Take (Other, Best);
               Watch.Run (Other);
               Set_True (Gates (Other));
            end if;
         end loop;
         Done := True;
      end Commit;

      --  Whether a waiting task waits for a time
      function Waits_For_Time (Index : Task_Index) return Boolean is
         State : State_Record renames States (Tasks (Index).First_State + Parties (Index).State);
      begin
         return (for some M in State.First_Move .. State.First_Move + State.Moves - 1 =>
                   Due (Index, Channel_Of (Moves (M).Event)) > Now);
      end Waits_For_Time;

      procedure Submit (Index : Task_Index; State : State_Index) is
         Done : Boolean;
      begin
         Parties (Index).State := State;
         Waiting := Waiting or Bit (Index);
         Commit (Index, Done);
         if not Done then
            Watch.Wait (Index, Waits_For_Time (Index));
         end if;
      end Submit;

      procedure Outcome (Index : Task_Index; Event : out Event_Index; Next : out State_Index) is
      begin
         Event := Parties (Index).Taken;
         Next := Parties (Index).Next;
      end Outcome;

      procedure Pass_Time is
         Done : Boolean;
      begin
         Now := Now + 1;
         for Index in Task_Index loop
            if (Waiting and Bit (Index)) /= 0 then
               Commit (Index, Done);
            end if;
         end loop;
         for Index in Task_Index loop
            if (Waiting and Bit (Index)) /= 0 then
               Watch.Wait (Index, Waits_For_Time (Index));
            end if;
         end loop;
      end Pass_Time;

      procedure Start (Value : Unsigned_32) is
      begin
         Random := (if Value = 0 then 2463534242 else Value);
      end Start;

   end Board;

   protected body Link is

      --  From the slot after the last one taken on, so that nobody is passed over for ever
      procedure Look is
         Slot : Positive := Last;
      begin
         for Step in 1 .. Senders loop
            Slot := (if Slot = Senders then 1 else Slot + 1);
            if Full (Slot) and then Find (Receiver, Wanted, Events (Slot)) /= 0
              and then (not Ready or else Channels (Channel_Of (Events (Slot))).Rank
                          < Channels (Channel_Of (Events (Chosen))).Rank)
            then
               Chosen := Slot;
               Ready := True;
            end if;
         end loop;
      end Look;

      procedure Put (Slot : Positive; Sender : Task_Index; Event : Event_Index) is
      begin
         Events (Slot) := Event;
         Owners (Slot) := Sender;
         Full (Slot) := True;
         if Wanting and then not Ready then
            Look;
            if Ready then
               Watch.Run (Receiver);
               Set_True (Gates (Receiver));
            end if;
         end if;
         Watch.Wait (Sender, For_Time => False);
      end Put;

      procedure Want (Place : State_Index; Found : out Boolean) is
      begin
         Wanted := Place;
         Wanting := True;
         Look;
         Found := Ready;
         if not Ready then
            Watch.Wait (Receiver, For_Time => False);
         end if;
      end Want;

      procedure Get (Event : out Event_Index; Sender : out Task_Index; Open : out Boolean) is
      begin
         Event := Events (Chosen);
         Sender := Owners (Chosen);
         Full (Chosen) := False;
         Last := Chosen;
         Wanting := False;
         Ready := False;
         Watch.Transfer (Event, Sender, Open);
      end Get;

   end Link;

   procedure Seed (Value : Natural) is
   begin
      Board.Start (Unsigned_32 (Value));
   end Seed;

   procedure Go is
   begin
      for Index in Task_Index loop
         Set_True (Gates (Index));
      end loop;
   end Go;

   procedure Limit (Events : Natural) is
   begin
      Watch.Stop_After (Events);
   end Limit;

   function Happened return Natural is (Watch.Count);
   function State return Ending is (Watch.How);

   procedure Tick is
   begin
      Board.Pass_Time;
   end Tick;

   --  One event of a task: from a state to the next
   procedure Step (Index : Task_Index; Current : in out State_Index) is
      Row    : State_Record renames States (Tasks (Index).First_State + Current);
      Event  : Event_Index;
      Sender : Task_Index;
      Next   : State_Index;
      First  : Natural;
      Way    : Natural := 0;
      Open   : Boolean := True;
      Found  : Boolean;
   begin
      if Row.Ways > 0 then
         Board.Choose (Row.Ways, Way);
         Current := Ways (Row.First_Way + Way);
         return;
      end if;
      case Row.Mode is
         when Ends =>
            Watch.Leave (Index);
            Suspend_Until_True (Gates (Index));  --  which nobody opens any more
            return;
         when Sends =>
            Event := Moves (Row.First_Move).Event;
            Next := Moves (Row.First_Move).Next;
            Links.Put (Row.Link, Index, Event);
            Stay (Index);
         when Receives =>
            Links.Want (Row.Link, Current, Found);
            if not Found then
               Stay (Index);
            end if;
            Links.Get (Row.Link, Event, Sender, Open);
            if not Open then
               Suspend_Until_True (Gates (Index));
            end if;
            Set_True (Gates (Sender));
            First := Find (Index, Current, Event);
            if Alike (Index, Current, First) > 1 then
               Board.Choose (Alike (Index, Current, First), Way);
            end if;
            Next := Moves (First + Way).Next;
         when Meets =>
            Board.Submit (Index, Current);
            Stay (Index);
            Board.Outcome (Index, Event, Next);
            if Methods_Table.Has (Index, Channel_Of (Event)) then
               Methods_Table.Call (Index, Event);
               First := Find (Index, Current, Event);
               if First = 0 then
                  raise Constraint_Error with "a method gave a value that is not allowed there";
               end if;
               Watch.Note (Event, Open);
               Next := Moves (First).Next;
            end if;
      end case;
      Program_Data.Step (Index, Event);
      Current := Next;
   end Step;

   task body Carrier is
      Current : State_Index := Tasks (Index).Start;
   begin
      Suspend_Until_True (Gates (Index));
      loop
         Step (Index, Current);
      end loop;
   exception
      when Failure : others =>
         --  A method gave a value outside its range or raised something, or an assertion about the data does not hold.
         Recorder.Failure (Index, Ada.Exceptions.Exception_Name (Failure));
         Watch.Fail;
   end Carrier;

end CSP;
