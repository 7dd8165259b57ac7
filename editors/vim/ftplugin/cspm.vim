" :make checks the script; the quickfix list has its errors and the assertions that fail.
if exists("b:did_ftplugin")
  finish
endif
let b:did_ftplugin = 1

setlocal commentstring=--\ %s
setlocal makeprg=cspcheck\ --format\ concise\ %:S
setlocal errorformat=%f:%l:%c:\ %m,%f:%l:\ %m
let b:undo_ftplugin = "setlocal commentstring< makeprg< errorformat<"
