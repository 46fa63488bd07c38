# find_package(ServoId) gives ServoId::servo_id, the library of this machine, or of the target in SERVO_ID_TARGET.
get_filename_component(_servo_id "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
file(GLOB _servo_id_targets RELATIVE "${_servo_id}/lib" "${_servo_id}/lib/*/libservo_id.a")
list(TRANSFORM _servo_id_targets REPLACE "/libservo_id.a$" "")
if(NOT DEFINED SERVO_ID_TARGET AND NOT CMAKE_CROSSCOMPILING)
    set(SERVO_ID_TARGET "${_servo_id_targets}")
    list(FILTER SERVO_ID_TARGET EXCLUDE REGEX "-none-")
endif()
if(NOT SERVO_ID_TARGET IN_LIST _servo_id_targets)
    set(ServoId_FOUND FALSE)
    set(ServoId_NOT_FOUND_MESSAGE "set SERVO_ID_TARGET to one of: ${_servo_id_targets}")
    return()
endif()
if(NOT TARGET ServoId::servo_id)
    add_library(ServoId::servo_id STATIC IMPORTED)
    set_target_properties(ServoId::servo_id PROPERTIES
        IMPORTED_LOCATION "${_servo_id}/lib/${SERVO_ID_TARGET}/libservo_id.a"
        INTERFACE_INCLUDE_DIRECTORIES "${_servo_id}/include")
endif()
