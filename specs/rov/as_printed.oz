-- The vehicle's classes as chapter 5 of the thesis prints them, its slips included.
--
-- This script is refused, and that is its purpose: each message is a place where the printed specification contradicts
-- itself. `classes.csp` is the same with just those places mended. Boxes that the scan lost are filled in from the text
-- around them and from the code of Annex B. Comments say where the original cannot be written at all.

COMPASS_TYPE ::= {x : real | 0 <= x <= 360}
ALTIMETER_TYPE ::= {x : real | 0 <= x <= 300}
SPEED_TYPE ::= {x : real | -1 <= x <= 1}
TORQUE_TYPE ::= {x : real | -100 <= x <= 100}
STATUS ::= normal | alert
given MESSAGE

schema SONAR_TYPE
  readings : seq real
where
  forall i : 0..3 @ 0 <= readings(i) <= 1
end

schema SensorData
  direction : COMPASS_TYPE
  depth : ALTIMETER_TYPE
  sonar : SONAR_TYPE
init
  direction = 0
  depth = 0
  forall i : 0..3 @ sonar(i) = 0           -- SONAR_TYPE is a schema: its field is `readings`
end

schema ControlData
  vx : SPEED_TYPE
  vy : SPEED_TYPE
  vz : SPEED_TYPE
  vTheta : SPEED_TYPE
init
  vx = 0
  vy = 0
  vz = 0
  vTheta = 0
end

schema ActuationData
  thruster1 : TORQUE_TYPE
  thruster2 : TORQUE_TYPE
  thruster3 : TORQUE_TYPE
  thruster4 : TORQUE_TYPE
  thruster5 : TORQUE_TYPE
  thruster6 : TORQUE_TYPE
  thruster7 : TORQUE_TYPE
  thruster8 : TORQUE_TYPE
init
  thruster1 = 0
  thruster2 = 0
  thruster3 = 0
  thruster4 = 0
  thruster5 = 0
  thruster6 = 0
  thruster7 = 0
  thruster8 = 0
end

const Clock : nat end                      -- printed as a schema with the output clock!; used as a value

class Periodic
  method getNextExecution
  const PERIOD : nat where PERIOD = 100
  state
    nextExecution : nat
  where
    nextExecution > 0
  init
    nextExecution = Clock
  op getNextExecution
    Delta(nextExecution)
  where
    nextExecution' = nextExecution + PERIOD
end

class BaseReader                           -- the box is lost; written from section 5.3.1 and Annexes A and B
  chan baseReader_remote : [msg : MESSAGE]
  chan baseReader_autonomo : [msg : MESSAGE]
  method getMessage
  method saveReceptionTime
  main = getMessage -> saveReceptionTime -> baseReader_remote -> main
  state
    receivedMsg : MESSAGE
  op getMessage
    Delta(receivedMsg)
  op com_baseReader_remote
    msg! : MESSAGE
  where
    msg! = receivedMsg
end

class Remote                               -- the box is lost; written from section 5.3.2 and Annex B
  chan baseReader_remote : [msg : MESSAGE]
  chan remote_s1 : [remoteData : ControlData]
  method decodeMessage
  main = baseReader_remote -> decodeMessage -> remote_s1 -> main
  state
    baseMsg : MESSAGE
    ctrlData : ControlData
  init
    ctrlData.INIT
  op com_baseReader_remote
    Delta(baseMsg)
    msg? : MESSAGE
  where
    baseMsg' = msg?
  op decodeMessage
    Delta(ctrlData)
  op com_remote_s1
    remoteData! : ControlData
  where
    remoteData! = ctrlData
end

class Autonomous
  chan ethReader_autonomous : [msg : MESSAGE]
  chan sensor_autonomous : [sensrData : SensorData]
  chan autonomous_s1 : [ctrlData : ControlData]
  main = SKIP
end

class S1
  chan remote_s1 : [remoteData : ControlData]
  chan autonomous_s1 : [autonomousData : ControlData]
  chan s1_moveToGoal : [s1Data : ControlData]
  main = (remote_s1 -> s1_moveToGoal -> main) [] (autonomous_s1 -> s1_moveToGoal -> main)
  state
    controlData : ControlData
  init
    controlData.INIT
  op com_remote_s1
    Delta(controlData)
    remoteData? : ControlData
  where
    controlData' = remoteData?
  op com_autonomous_s1
    Delta(controlData)
    remoteData? : ControlData
  where
    controlData' = remoteData?
  op com_s1_moveToGoal
    Delta()
    s1Data! : ControlData
  where
    s1Data' = controlData
end

class BlackBoard                           -- the box is lost; written from section 5.4 and Annex B
  chan putDirection : [reading : COMPASS_TYPE]
  chan putDepth : [reading : ALTIMETER_TYPE]
  chan putSonar : [reading : SONAR_TYPE]
  chan getSensorReadings : [readings : SensorData]
  main = putDirection -> main [] putDepth -> main [] putSonar -> main [] getSensorReadings -> main
  state
    sensors : SensorData
  init
    sensors.INIT
end

class Compass
  inherit Periodic
  method getDirection
  method saveDirection
  main = getDirection -> saveDirection -> getNextExecution -> main     -- Delay until(nextExecution) comes first
  state
    direction : COMPASS_TYPE
    blkBoard : Blackboard
  init
    direction.INIT
  op getDirection
    Delta(direction)
  op saveDirection
    Delta(blkBoard)                        -- blkBoard.putDirection(direction)
end

class Altimeter
  inherit Periodic
  method getDepth
  method saveDepth
  main = getDepth -> saveDepth -> getNextExecution -> main
  state
    depth : ALTIMETER_TYPE
    blkBoard : BlackBoard
  init
    depth.INIT
  op getDepth
    Delta(depth)
  op saveDepth
    Delta(blkBoard)                        -- blkBoard.saveDepth(depth), which the BlackBoard calls otherwise
end

class Sonar                                -- the box is lost; written from section 5.4.3 and Annex B
  inherit Periodic
  method getSonar
  method saveSonar
  main = getSonar -> saveSonar -> getNextExecution -> main
  state
    sonar : SONAR_TYPE
  op getSonar
    Delta(sonar)
  op saveSonar
    Delta()
end

class BaseWriter                           -- the box is lost; written from section 5.4.4 and Annex B
  chan sensor_baseWriter : [msg : MESSAGE]
  method sendMessage
  main = sensor_baseWriter -> sendMessage -> main
  state
    msgToSend : MESSAGE
  op com_sensor_baseWriter
    Delta(msgToSend)
    msg? : MESSAGE
  where
    msgToSend' = msg?
  op sendMessage
    Delta()
end

class S2                                   -- the box is lost; written from section 5.4.7 and Annex B
  chan move_s2 : [moveData : ControlData]
  chan stop_s2 : [stopData : ControlData]
  chan s2_actuator : [s2Data : ControlData]
  main = (stop_s2 -> s2_actuator -> main) [] (move_s2 -> s2_actuator -> main)
end

class ThrusterWriter
  chan actuator_thruster : [actuatorData : ActuationData]
  method generateMessage
  method sendMessage
  main = actuator_thruster -> generateMessage -> sendMessage -> main   -- generateMessage(setpoints), ...
  state
    setpoints : ActuationData
    controllerMsg : MESSAGE
  init
    actuationData.INIT
  op com_actuator_thruster
    Delta(setpoints)
    actuatorData? : ActuationData
  where
    setpoints' = actuatorData?
  op generateMessage
    Delta(controllerMsg)                   -- controllerMsg' = <$> ^ <i> ^ <setpoints.thruster1> ^ ... ^ <$>; no `$` here
  op sendMessage
    Delta()
    controllerMsg? : MESSAGE
end

class Move
  chan s1_move : [s1Data : ControlData]
  chan avoid_move : [avoidCollData : STATUS]
  chan move_s2 : [moveData : ControlData]
  method getNextMovement
  main = s1_move -> avoid_move -> getNextMovement -> move_s2 -> main
  state
    dangerLevel : STATUS
    speedData : ControlData
    avoidData : ControlData
    movement : ControlData
  init
    speedData.INIT
    avoidData.INIT
    movement.INIT
  op com_s1_move
    Delta(speedData)
    s1Data? : ControlData
  where
    speedData' = s1Data?
  op com_avoid_move
    Delta(avoidData)
    avoidCollData? : STATUS
  where
    dangerLevel' = avoidCollData?
  op com_move_s2
    Delta()
    moveData! : ControlData
  where
    moveData! = movement
  op getNextMovement
    Delta(movement, avoidData)
  where
    if dangerLevel = normal
    then movement' = speedData and avoidData' = -speedData
    else movement' = avoidData
end

class Stop
  inherit Periodic
  chan stop_s2 : [stopData : ControlData]
  method checkLastReception
  main =                                   -- (if (Clock - lastReception > TIMEOUT) then stop_s2) stands in the middle
    checkLastReception -> (stop_s2 -> getNextExecution -> main |~| getNextExecution -> main)
  const TIMEOUT : nat where TIMEOUT = 1000
  state
    lastReception : nat
    stop : ControlData
  where
    lastReception > 0
  init
    lastReception = Clock
    stop.INIT
  op checkLastReception
    Delta(lastReception)
  op com_stop_s2
    Delta()
    stopData! : ControlData
  where
    stopData! = stop
end

class Sensor
  inherit Periodic
  chan sensor_baseWriter : [sensrData : MESSAGE]
  method structureToMessage
  method getSensors
  main = getSensors -> structureToMessage -> sensor_baseWriter -> getNextExecution -> main
  state
    sensors : SensorData
    blkBoard : BlackBoard
  init
    sensors.INIT
  op com_sensor_baseWriter
    Delta()
    sensrData! : MESSAGE
  where
    sensrData! = structureToMessage        -- an operation with an output, used as a function
  op getSensors
    Delta(sensors)
  where
    sensors' = blkBoard.getSensorReadings
  op structureToMessage
    Delta()
    message! : MESSAGE                     -- message! = <$> ^ <d> ^ sensors.direction ^ <h> ^ sensors.depth ^ <$>
end

class AvoidCollision
  inherit Periodic
  chan avoid_move : [avoidCollisionData : ControlData]
  method generateAvoid
  main = generateAvoid -> avoid_move -> getNextExecution -> main
  state
    avoidData : STATUS
    sonars : SONAR
  init
    avoidData.INIT
    forall i : 0..3 @ sonarData(i) = 0
  op generateAvoid
    Delta(avoidData)
  where
    forall i : 0..3 @ if sonars(i) > LIMIT then avoidData' = alert else avoidData' = normal
  op com_avoid_move
    Delta()
    avoidCollisionData! : ControlData
  where
    avoidCollisionData! = avoidData
end

class Actuator
  chan s2_actuator : [s2Data : ControlData]
  chan actuator_thruster : [actuatorData : ActuationData]
  chan generateSetpoints
  main = s2_actuator -> generateSetpoints -> actuator_thruster -> main
  state
    ctrlData : ControlData
    setpoints : ActuationData
  init
    ctrlData.INIT
    setpoints.INIT
  op com_s2_actuator
    Delta(ctrlData)
    s2Data? : ControlData
  where
    ctrlData' = s2Data?
  op com_actuator_thruster
    Delta()
    actuatorData! : ActuationData
  where
    actuatorData! = setpoints
  op generateSetpoints
    Delta(setpoints)
  where
    setpoints'.thruster1 = 10.0
    setpoints'.thruster2 = 20.0
    setpoints'.thruster3 = 30.0
    setpoints'.thruster4 = 40.0
    setpoints'.thruster5 = 50.0
    setpoints'.thruster6 = 60.0
    setpoints'.thruster7 = 70.0
    setpoints'.thruster8 = 80.0
end

-- Figure 5.1
ROV_Control_Module =
  BaseReader || Remote || Autonomous || S1 || Move || S2 || Stop || AvoidCollision || Sensor || Actuator || ThrusterWriter
  || Compass || Altimeter || Sonar || BaseWriter
