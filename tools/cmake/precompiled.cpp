// A unit for the headers that all rooms read (rooms.cmake).
