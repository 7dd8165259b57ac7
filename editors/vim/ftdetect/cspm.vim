" `set`, not `setfiletype`: Vim itself calls these files `csp`, and is asked first.
autocmd BufRead,BufNewFile *.csp,*.cspm set filetype=cspm
