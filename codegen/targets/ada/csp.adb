with Interfaces; use Interfaces;
with Methods_Table;

package body CSP is

   subtype Word is Unsigned_64;

   Log : array (1 .. Most_Recorded) of Event_Index := (others => 0);

   function Bit (Index : Task_Index) return Word is (Shift_Left (Word'(1), Index));

   --  What a waiting task offers, and what was chosen for it
   type Party is record
      State    : State_Index := 0;
      Taken    : Event_Index := 0;
      Next     : State_Index := 0;
      Tocks    : Natural := 0;
      Releases : Natural := 0;
   end record;
   type Party_Array is array (Task_Index) of Party;

   All_Tasks : constant Word :=
     (if Task_Count = 64 then Word'Last else Shift_Left (Word'(1), Task_Count) - 1);

   protected type Gate with Priority => System.Priority'Last is
      entry Pass;
      procedure Open;
   private
      Is_Open : Boolean := False;
   end Gate;

   protected body Gate is
      entry Pass when Is_Open is
      begin
         Is_Open := False;
      end Pass;

      procedure Open is
      begin
         Is_Open := True;
      end Open;
   end Gate;

   Gates : array (Task_Index) of Gate;

   --  The procedures of it are the only ones that change what it knows
   protected Board with Priority => System.Priority'Last is
      procedure Submit (Index : Task_Index; State : State_Index);
      procedure Outcome (Index : Task_Index; Event : out Event_Index; Next : out State_Index);
      procedure Perform (Index : Task_Index; State : State_Index; Event : Event_Index; Next : out State_Index);
      procedure Fail;
      procedure Leave (Index : Task_Index);
      procedure Pass_Time;
      procedure Choose (Count : Positive; Taken : out Natural);
      procedure Start (Value : Unsigned_32);
      procedure Stop_After (Events : Natural);
      function Count return Natural;
      function How return Ending;
   private
      Parties  : Party_Array;
      Waiting  : Word := 0;
      Alive    : Word := All_Tasks;
      Number   : Natural := 0;
      Most     : Natural := Natural'Last;
      Now      : Natural := 0;
      Closed   : Ending := Goes_On;
      Random   : Unsigned_32 := 2463534242;
   end Board;

   protected body Board is

      procedure Draw (Count : Positive; Taken : out Natural) is
      begin
         Random := Random xor Shift_Left (Random, 13);
         Random := Random xor Shift_Right (Random, 17);
         Random := Random xor Shift_Left (Random, 5);
         Taken := Natural (Random mod Unsigned_32 (Count));
      end Draw;

      function Due (Index : Task_Index; Channel : Channel_Index) return Natural is
        (if Channels (Channel).Clocked then (Parties (Index).Tocks + 1) * Tock_Ms
         elsif Tasks (Index).Timed = Channel
         then Tasks (Index).Offset_Ms + Parties (Index).Releases * Tasks (Index).Period_Ms
         else 0);

      --  The first move of a waiting task with an event; 0 if there is none
      function Find (Index : Task_Index; Event : Event_Index) return Natural is
         State : State_Record renames States (Tasks (Index).First_State + Parties (Index).State);
         Low   : Natural := State.First_Move;
         High  : Natural := State.First_Move + State.Moves;
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
         return (if Low < State.First_Move + State.Moves and then Moves (Low).Event = Event then Low else 0);
      end Find;

      function All_Offer (Group : Word; But : Task_Index; Event : Event_Index) return Boolean is
        (for all Index in Task_Index =>
           (Group and Bit (Index)) = 0 or else Index = But
           or else (Due (Index, Channel_Of (Event)) <= Now and then Find (Index, Event) /= 0));

      procedure Take (Index : Task_Index; Event : Event_Index) is
         First : constant Natural := Find (Index, Event);
         State : State_Record renames States (Tasks (Index).First_State + Parties (Index).State);
         Count : Positive := 1;
         Which : Natural := 0;
      begin
         pragma Assert (First /= 0);
         while First + Count < State.First_Move + State.Moves and then Moves (First + Count).Event = Event loop
            Count := Count + 1;
         end loop;
         if Count > 1 then
            Draw (Count, Which);
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

      procedure Note (Event : Event_Index) is
      begin
         Number := Number + 1;
         if Number <= Most_Recorded then
            Log (Number) := Event;
         end if;
         if Number >= Most then
            Closed := Enough;
         end if;
      end Note;

      procedure Commit (Index : Task_Index; Done : out Boolean) is
         State : State_Record renames States (Tasks (Index).First_State + Parties (Index).State);
         Start : Natural := 0;
         Best  : Event_Index := 0;
         Group : Word := 0;
         Rank  : Natural := Natural'Last;
      begin
         Done := False;
         if Closed /= Goes_On or else State.Moves = 0 then
            return;
         end if;
         if State.Moves > 1 then
            Draw (State.Moves, Start);
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
         if not Methods_Table.Has (Index, Channel_Of (Best)) or else Group /= Bit (Index) then
            Note (Best);
         end if;
         for Other in Task_Index loop
            if (Group and Bit (Other)) /= 0 then
               Take (Other, Best);
               Gates (Other).Open;
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

      procedure Look_For_The_End is
      begin
         if Closed = Goes_On and then Waiting = Alive then
            if Alive = 0 then
               Closed := Ended;
            elsif not (for some Index in Task_Index =>
                         (Alive and Bit (Index)) /= 0 and then Waits_For_Time (Index))
            then
               Closed := Deadlock;
            end if;
         end if;
      end Look_For_The_End;

      procedure Submit (Index : Task_Index; State : State_Index) is
         Done : Boolean;
      begin
         Parties (Index).State := State;
         Waiting := Waiting or Bit (Index);
         Commit (Index, Done);
         if not Done then
            Look_For_The_End;
         end if;
      end Submit;

      procedure Outcome (Index : Task_Index; Event : out Event_Index; Next : out State_Index) is
      begin
         Event := Parties (Index).Taken;
         Next := Parties (Index).Next;
      end Outcome;

      procedure Perform (Index : Task_Index; State : State_Index; Event : Event_Index; Next : out State_Index) is
      begin
         Parties (Index).State := State;
         Next := State;
         if Find (Index, Event) = 0 then
            Closed := Broken;
         else
            if Closed = Goes_On then
               Note (Event);
            end if;
            Next := Moves (Find (Index, Event)).Next;
         end if;
      end Perform;

      procedure Fail is
      begin
         Closed := Broken;
      end Fail;

      procedure Leave (Index : Task_Index) is
      begin
         Alive := Alive and not Bit (Index);
         Look_For_The_End;
      end Leave;

      procedure Pass_Time is
         Done : Boolean;
      begin
         Now := Now + 1;
         for Index in Task_Index loop
            if (Waiting and Bit (Index)) /= 0 then
               Commit (Index, Done);
            end if;
         end loop;
      end Pass_Time;

      procedure Choose (Count : Positive; Taken : out Natural) is
      begin
         Draw (Count, Taken);
      end Choose;

      procedure Start (Value : Unsigned_32) is
      begin
         Random := (if Value = 0 then 2463534242 else Value);
      end Start;

      procedure Stop_After (Events : Natural) is
      begin
         Most := Events;
      end Stop_After;

      function Count return Natural is (Number);
      function How return Ending is (Closed);

   end Board;

   procedure Seed (Value : Natural) is
   begin
      Board.Start (Unsigned_32 (Value));
   end Seed;

   procedure Decide (Count : Positive; Taken : out Natural) is
   begin
      Board.Choose (Count, Taken);
   end Decide;

   procedure Limit (Events : Natural) is
   begin
      Board.Stop_After (Events);
   end Limit;

   function Happened return Natural is (Board.Count);
   function Recorded (Number : Positive) return Event_Index is (Log (Number));
   function State return Ending is (Board.How);

   procedure Tick is
   begin
      Board.Pass_Time;
   end Tick;

   task body Carrier is
      Current : State_Index := Tasks (Index).Start;
      Event   : Event_Index;
      Next    : State_Index;
      Way     : Natural;
   begin
      loop
         declare
            Row : State_Record renames States (Tasks (Index).First_State + Current);
         begin
            if Row.Ways > 0 then
               Decide (Row.Ways, Way);
               Current := Ways (Row.First_Way + Way);
            else
               if Row.Ends then
                  Board.Leave (Index);
               else
                  Board.Submit (Index, Current);
               end if;
               --  The gate of a task that has ended, or comes too late, is not opened any more.
               Gates (Index).Pass;
               Board.Outcome (Index, Event, Next);
               if Methods_Table.Has (Index, Channel_Of (Event)) then
                  Methods_Table.Call (Index, Event);
                  Board.Perform (Index, Current, Event, Next);
               end if;
               Current := Next;
            end if;
         end;
      end loop;
   exception
      when others =>
         Board.Fail;  --  a method gave a value outside its range, or raised something
   end Carrier;

end CSP;
